"""The rules of ``orusd validate``: USD's own validators, and ours about layers and about prims."""
