"""What is done with simulations: rooms settle, robots drive and see; knows engines by contract."""
