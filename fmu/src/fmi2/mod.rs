//! The FMI 2.0 Co-Simulation boundary: generic over any [`crate::model::Model`].
