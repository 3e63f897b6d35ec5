"""Parts of the obstacle arena: solids, yards, walls, frames, nets, its ground and its zones."""
