"""Retrieval and registration of CADs to the objects of a scan.

In the order of the work:

- `hints`: given poses, boxes and categories; `evidence`, `selection`: the points of one object,
  and CADs ranked by shape;
- `scalelimits`: how far a CAD may be scaled, and the prior of its true size; `template`: a
  CAD with its seven parameters;
- `supportheights`, `surroundings`: supports, walls, the residuals of contacts;
- `hypotheses`, `priors`: poses from coarse to fine, and their covariance; `fitting`: robust ICP;
- `alignment`: all objects of a scan.
"""
