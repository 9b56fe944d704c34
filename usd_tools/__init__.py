"""Read and write UsdSkel animation, and the commands that interpolate it with `geomstats_anim`.

There is no mathematics in this package: it is files, composition and command lines.
"""
