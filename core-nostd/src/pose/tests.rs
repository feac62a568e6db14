//! The fit against paper 001: golden values, the reference's tables, and a dense solution in double precision.

mod dense;
mod fit;
mod table;
