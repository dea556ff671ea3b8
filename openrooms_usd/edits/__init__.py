"""What people change in a composed room: what is lost, and how it is kept."""
