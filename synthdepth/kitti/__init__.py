"""KITTI in its several layouts, read as samples."""
