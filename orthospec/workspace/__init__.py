"""From a design to its cuboids: grid, field, largest cuboid, critical points, polish, evaluation."""
