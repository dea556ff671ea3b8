"""The fuzz campaign: broken and hostile input of every kind, and what becomes of it.

``python -m benchmarks.fuzz`` plants small sound inputs, spoils one file of one of them for each
case, and gives it to the command that reads it. Whatever is in a file, a command may refuse it in
one sentence or accept it; everything else is a defect.
"""
