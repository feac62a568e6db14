//! The pose's streams and fits against paper 001: golden values, the reference's tables, a dense solution in double
//! precision, and what sensors do in the field.

mod dense;
mod fit;
mod history;
mod position;
mod smoother;
mod streams;
mod table;
