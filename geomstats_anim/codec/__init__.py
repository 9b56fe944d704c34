"""Packed animation: motion in few bytes, no marker further from its place than a tolerance."""

from geomstats_anim.codec.decoder import unpack, unpack_channels
from geomstats_anim.codec.encoder import pack
from geomstats_anim.codec.packer import ExtraChannel
from geomstats_anim.codec.stream import StreamError

__all__ = ["ExtraChannel", "StreamError", "pack", "unpack", "unpack_channels"]
