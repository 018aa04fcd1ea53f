"""Runs pytest inside Blender: blender -b --addons ajar_render --python run.py -- FILE [pytest arguments]"""

import os
import sys

import pytest

code = pytest.main(["-q", "-p", "no:cacheprovider", "--rootdir", os.path.dirname(__file__), *sys.argv[sys.argv.index("--") + 1:]])
sys.stdout.flush()
sys.stderr.flush()
os._exit(int(code))
