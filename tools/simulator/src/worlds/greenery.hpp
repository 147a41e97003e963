#pragma once
/// Trees, bushes and hedges: wood as solids, foliage as single leaves that let rays through between them.

#include "aslio/simulator/mesh.hpp"
#include "aslio/simulator/random.hpp"

namespace aslio::simulator::outdoor {

/// About the origin of the placement on the ground.
void add_tree(MeshBuilder& builder, RandomStream& random, double height);
void add_bush(MeshBuilder& builder, RandomStream& random, double radius, double height);
/// From the origin of the placement along x, its width about y = 0.
void add_hedge(MeshBuilder& builder, RandomStream& random, double length, double width, double height);

}  // namespace aslio::simulator::outdoor
