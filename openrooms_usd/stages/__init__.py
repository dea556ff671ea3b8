"""The stages: each reads the composed stage below it and writes one layer."""
