"""Rigid bodies as arrays: masses, collision shapes, contacts; knows no USD and no engine."""
