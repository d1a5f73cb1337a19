//! Graph-network emulators of soft-tissue mechanics, trained on simulations or on potential energy
