"""Functional groups of furniture: what is used together stands together."""
