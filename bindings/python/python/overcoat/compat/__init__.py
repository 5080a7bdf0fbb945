"""Functions of other libraries, drawn by overcoat: programs that use them change one import.

- `overcoat.compat.pyrender`: `OffscreenRenderer`
- `overcoat.compat.trimesh`: `save_image`
"""
