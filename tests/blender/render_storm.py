"""python render_storm.py IN.usda CAMERA FRAME WIDTH OUT.png - render a frame by Storm, with Blender's own OpenUSD.

It needs a display, such as Xvfb, and OpenGL 4.5, such as Mesa's llvmpipe: Storm draws into whatever context is current.
"""

import ctypes
import sys

import bpy

_PBUFFER, _RGBA = 4, 1
_CONFIG = {0x8010: _PBUFFER, 0x8011: _RGBA, 8: 8, 9: 8, 10: 8, 11: 8, 12: 24}
"""GLX: drawable, render type, bits of red, green, blue, alpha and depth."""
_VERSION = {0x2091: 4, 0x2092: 5, 0x9126: 2}
"""OpenGL 4.5, with what is older."""
_SIZE = {0x8041: 16, 0x8040: 16}


def make_context():
    """Make an OpenGL context current, which draws nowhere."""
    x, gl = ctypes.CDLL("libX11.so.6"), ctypes.CDLL("libGL.so.1", mode=ctypes.RTLD_GLOBAL)
    pointer = ctypes.c_void_p
    x.XOpenDisplay.restype = gl.glXGetProcAddress.restype = gl.glXCreatePbuffer.restype = pointer
    gl.glXChooseFBConfig.restype = ctypes.POINTER(pointer)
    gl.glXMakeContextCurrent.argtypes = [pointer] * 4
    display = pointer(x.XOpenDisplay(None))
    assert display, "there is no display"
    found = gl.glXChooseFBConfig(display, 0, _numbers(_CONFIG), ctypes.byref(ctypes.c_int()))
    assert found, "the display has no such buffers"
    config = pointer(found[0])
    kind = ctypes.CFUNCTYPE(pointer, pointer, pointer, pointer, ctypes.c_int, ctypes.POINTER(ctypes.c_int))
    create = kind(gl.glXGetProcAddress(b"glXCreateContextAttribsARB"))
    context = create(display, config, None, 1, _numbers(_VERSION))
    buffer = gl.glXCreatePbuffer(display, config, _numbers(_SIZE))
    assert gl.glXMakeContextCurrent(display, buffer, buffer, context), "OpenGL 4.5 cannot be had"


def _numbers(attributes):
    flat = [number for pair in attributes.items() for number in pair]
    return (ctypes.c_int * (len(flat) + 1))(*flat, 0)


def main():
    """Render."""
    source, camera, frame, width, out = sys.argv[1:]
    bpy.utils.expose_bundled_modules()
    from pxr import Usd, UsdAppUtils, UsdGeom

    make_context()
    stage = Usd.Stage.Open(source)
    recorder = UsdAppUtils.FrameRecorder()
    recorder.SetRendererPlugin("HdStormRendererPlugin")
    recorder.SetImageWidth(int(width))
    recorder.SetColorCorrectionMode("disabled")
    assert recorder.Record(stage, UsdGeom.Camera.Get(stage, camera), Usd.TimeCode(float(frame)), out)


main()
