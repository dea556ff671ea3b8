"""The stages: each reads the composed stage below it and writes one layer.

- `base`, `runner`, `draft`, `reports`: the contract, what runs one, where its layer waits;
- `captures`, `captured`, `scanned`, `drawn`: what comes from a capture or a scan, or was drawn
  over it;
- `layout` (`partitions`, `openings`, `joinery`, `trim`, `beyond`, `decor`, `surroundings`);
- `alignment` (`catalogue`, `placement`, `poses`, `tops`, `following`, `substitutes`, `aligned`,
  `furnished`, `instances`, `segmented`, `shelf`);
- `materials` (`surfaces`, `swatches`, `choosing`, `palette`, `appearance`, `dressing`, `looks`);
- `lights` (`daylight`, `nearby`, `glow`, `screens`); `cameras` (`selection`, `subjects`,
  `photographs`, `exposure`); `physics`.
"""
