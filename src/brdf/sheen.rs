//! Distributions and visibility of cloth: Charlie and Neubelt.
