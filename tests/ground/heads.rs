//! A camera of several heads against paper 002's geometry: the golden projection through every way there is to it, the
//! core's single precision over an image of the paper's size, and simulated virtual images beside those of one camera.

mod four;
mod geometry;
mod stitched;
