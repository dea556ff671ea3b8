"""Retrieval and registration of CADs to the objects of a scan.

In the order of the work:

- `hints`: given poses, boxes and categories; `evidence`, `selection`: the points of one object,
  and CADs ranked by shape;
- `scalelimits`: how far a CAD may be scaled; `template`: a CAD with its seven parameters;
- `wallsides`, `supportheights`, `surroundings`: walls, supports, the residuals of contacts;
- `hypotheses`, `priors`: initial poses and their covariance; `discs`, `fitting`: robust ICP;
- `posesearch`: hypotheses from coarse to fine; `truesize`: a prior of scale over all objects;
- `alignment`: all objects of a scan.
"""
