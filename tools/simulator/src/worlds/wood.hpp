#pragma once
/// Trees as they grow in a wood, bushes, ferns, logs and rocks; each about the origin of the placement on the ground.

#include "aslio/simulator/mesh.hpp"
#include "aslio/simulator/random.hpp"

namespace aslio::simulator::outdoor {

struct Tree {
  double height = 14;   ///< [m]
  double radius = 0.2;  ///< of the trunk at breast height [m]
  Vec2 lean{0, 0};      ///< of the trunk, per metre of height
  Vec2 curve{0, 0};     ///< and how much the top turns away from that [m]
  bool conifer = false;
  /// The foot of the trunk: radius of its roots' collar [m].
  double foot() const { return 1.6 * radius; }
};
Tree draw_tree(RandomStream& random, double lean);
/// Trunk of `sides` faces with a widened foot, branches, leaves; no leaf is lower than 2.6 m.
void add_tree(MeshBuilder& builder, RandomStream& random, const Tree& tree, int sides);

/// Stems and leaves in a volume, without a core.
void add_leafy_bush(MeshBuilder& builder, RandomStream& random, double radius, double height);
/// A tuft of narrow leaves.
void add_fern(MeshBuilder& builder, RandomStream& random, double radius);
/// A round boulder.
void add_rock(MeshBuilder& builder, const Vec3& radii);

}  // namespace aslio::simulator::outdoor
