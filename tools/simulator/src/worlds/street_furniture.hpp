#pragma once
/// What stands beside streets. Each about the origin of the placement on the ground, its front towards +y.

#include "aslio/simulator/mesh.hpp"
#include "aslio/simulator/random.hpp"

namespace aslio::simulator::outdoor {

/// With an arm of 1.2 m towards +y at the top.
void add_lamp_post(MeshBuilder& builder, double height);
void add_bollard(MeshBuilder& builder);
void add_bench(MeshBuilder& builder);
void add_bin(MeshBuilder& builder);
/// A panel on a post, `width` by `width` [m], its lower edge at 2.3 m.
void add_sign(MeshBuilder& builder, double width);
void add_cabinet(MeshBuilder& builder, RandomStream& random);
void add_bicycle_rack(MeshBuilder& builder, RandomStream& random);
/// Bus stop: three glass walls and a roof, 3.6 m by 1.4 m.
void add_shelter(MeshBuilder& builder);
/// Posts and rails from the origin along x.
void add_fence(MeshBuilder& builder, double length, double height);
/// Low wall with a coping from the origin along x.
void add_low_wall(MeshBuilder& builder, double length, double height);

}  // namespace aslio::simulator::outdoor
