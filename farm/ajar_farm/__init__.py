"""Rendering on a cluster: frames are divided into tasks of a Slurm array, and what the tasks have rendered is merged. Only Python's own library."""
