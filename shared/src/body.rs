//! The ten rigid body properties and their transforms.
