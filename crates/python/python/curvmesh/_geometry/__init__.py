"""Meshes, and what is computed on them. Nothing here imports the modules beside this folder but the base.

From below: ``arrays``, ``mesh``, ``packages``, ``files``, and one module for each function or two.
"""
