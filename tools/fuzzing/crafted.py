"""Inputs made by hand, a list a kind; they are fed before those that are drawn."""

from fuzzing.crafted_datasets import DATASETS
from fuzzing.crafted_models import LEARNING
from fuzzing.crafted_others import OTHERS

CRAFTED = DATASETS | LEARNING | OTHERS
