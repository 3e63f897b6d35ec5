"""The dataset contract: records, shards, manifest, checks and previews."""
