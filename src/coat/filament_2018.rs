//! Filament's clear coat as its documentation printed it in 2018.
