//! Every method of the paper (Arquès and Michelin), one file each, restated and corrected.
