// SPDX-License-Identifier: Apache-2.0
// How stiff a contact is: the skin has one stiffness whatever touches it, and so have soft things.
//
// MuJoCo holds a contact at rest with force = k depth where its `solref` is (-k (1 - d) A, -damping), d the impedance
// and A the inverse mass that it gives the contact: the sum of both bodies' `body_invweight0` (MuJoCo documentation,
// "Solver parameters"). So one number per geom cannot be right for partners of different mass; here every contact gets
// its own. Contacts of one pair of geoms share the stiffness of that pair in proportion to their depth, so that a flat
// face is as stiff as a ball. The skin's foam and the thing are springs in series.
// A light, stiff thing is no stiffer than steps of this length can follow.
#pragma once

#include <limits>
#include <vector>

#include "world/mounting.hpp"

struct mjContact_;

namespace robotskin::world {

// What a geom is made of.
struct Material {
  static constexpr double rigid = std::numeric_limits<double>::infinity();

  double stiffness_n_per_m = rigid;
  // False: the stiffness of one side of the whole thing, shared by all that presses it from there (a fruit).
  // True: each cell finds this stiffness under itself, whatever its neighbours do (flesh, foam).
  bool local = false;
  // A standard linear solid: of a press that lasts, this share of the force is lost, with this time constant.
  double relaxes_by = 0;
  double relaxes_in_s = 1;
};

class ContactLaw {
 public:
  ContactLaw(const mjModel_& model, const Mounting& mounting);

  // Gives the contacts that `mj_step1` has found their parameters, and builds the constraints anew if any changed.
  // Allocates nothing.
  void apply(const mjModel_& model, mjData_& data);

 private:
  struct Soft {
    mjContact_* contact;
    int geom[2];  // of a contact between skin and thing the cell comes first
    bool skin;
    double depth_m;
    double share;     // of the pair of geoms
    double pair_m;    // depth of the pair of geoms
    double side = 1;  // share of the pair in what presses the thing from this body
    double left = 1;  // share of the thing's stiffness after relaxation
  };

  // How deep a thing that relaxes has taken the shape of what presses it; a pair of geoms, the thing second.
  struct Taken {
    int geom[2];
    double depth_m;
    bool touched;
  };

  bool set(const mjModel_& model, const Soft& soft) const;
  // The share of its stiffness that a thing has left for what presses it.
  double left(const Soft& soft, double period_s);
  void forget_what_is_apart();

  std::vector<Material> material_;  // (ngeom)
  std::vector<char> cell_;          // (ngeom)
  std::vector<Soft> soft_;
  std::vector<Taken> taken_;
};

}  // namespace robotskin::world
