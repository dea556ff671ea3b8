"""The whole set of light channels from one set of first hits and one set of light samples.

- ``matter`` tells what every surface is made of, whatever its model.
- ``first_surface`` is what a camera's rays meet: its white frame, and the rest that it scatters.
- ``light_samples`` samples every light, ``accumulator`` files what it finds.
- ``meeting`` follows rays to the surfaces that stop them, and counts what emits on the way.
- ``integrator`` combines these; what surfaces scatter on comes from `transport.scattered`.
- ``smoothing`` averages indirect light over neighbours, ``smoothed`` makes pictures of it.
- ``channels`` makes the channels of the sums.
- ``denoiser_guides`` averages what surfaces look like over pixels.
"""
