//! three.js before the composition of today: r119 and r131.
