//! What a ray meets: visibility, optical depth, free space.
