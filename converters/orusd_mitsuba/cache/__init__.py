"""The light cache."""
