"""What stands along streets: poles, wires, signs, fences."""
