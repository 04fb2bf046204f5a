"""orthospec."""
