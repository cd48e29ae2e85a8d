// A case while it is generated: tooth, lesions, ideal shape. The recipes of recipes.cpp compose it.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/app/cases/case.h"
#include "engine/app/cases/pocket_gum.h"
#include "engine/base/json.h"
#include "engine/base/units.h"

namespace typodont {

using Ordered = nlohmann::ordered_json;

/// Converts m to mm, rounded to 0.1 µm.
double in_mm(double metres);

/// A carious lesion along the line a–b (u, v), from the surface down the axis w: `opening` at the surface, `width` at
/// the border of enamel and dentin, round in the dentin. Tissue around it has lost mineral.
struct Lesion {
  glm::dmat3 R{1};  // columns: the axes u, v, w in the tooth's frame
  glm::dvec2 a{0}, b{0};
  double top = 0, border = 0, depth = 0;  // m: surface's height w; depths of dentin and of lesion's end below it
  double opening = 0, width = 0;          // m, radii at the surface and at the enamel-dentin border
  int icdas = 5;                          // code 1 to 6, gives the hardness
  double affected = 0.35e-3;              // m, thickness of the tissue around that lost mineral

  struct Point {
    Tissue tissue = Tissue::kAir;
    double hardness = 1;  // fraction of the tissue's own
  };
  /// The tissue at p (tooth's frame) that was `sound`: caries, affected or unchanged.
  Point at(const dvec3& p, Tissue sound) const;
};

/// The generated case and its geometry. Points are in the axes u, v, w, m: w out of the cavity's opening, u mesial.
struct Draft {
  Case& out;
  const Json& family;
  SplitMix64& random;
  Ordered base;                   // shipped exercise that gives tools, motor and rules
  dvec3 offset{0};                // m, displacement from the tooth's frame to frame W
  haptics::DenseTissue tissue{};  // of the tooth, in the tooth's frame
  // What the task asks: an ideal shape, or a region to explore. Solids that are removed or added before the exercise.
  Ordered ideal = Ordered::object(), explore, prepare = Ordered::array();
  Ordered surroundings;                // the scene's block of this name; empty: none
  Ordered filling = Ordered::array();  // solids of an old filling
  std::vector<Lesion> lesions;
  std::optional<PocketGum> gum;
  glm::dmat3 R{1};     // columns: the axes u, v, w in the tooth's frame
  glm::dmat3 turn{1};  // rotation of the tooth in frame W, by quarter turns
  double lean = 0;     // rad, inclination of each wall of a cavity; above 0: the walls open outwards

  double mm(const char* name) const { return out.parameters.at(name) * kMillimetre; }
  bool has(const char* parameter) const { return out.parameters.contains(parameter); }
  /// Turns the tooth so that its buccal side faces the trainee.
  void show_buccal_side() { turn = {{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}}; }
  /// Lays the tooth down so that the side of the approach (buccal or lingual) faces up and its crown faces the trainee.
  /// `opening` (u, v, w) comes to the place of the cusps.
  void lay_down(const dvec3& opening);
  void approach_along(const dvec3& w) {
    const dvec3 u = glm::normalize(dvec3(1, 0, 0) - w.x * w);
    R = {u, glm::cross(w, u), w};
  }
  /// Adds gum that is only drawn: tools pass through it. `margin`: m, height of the gum's margin above the neck.
  void cover_with_gum(double margin);
  Ordered direction(const dvec3& d) const;
  dvec3 to_W(const dvec3& p) const { return turn * R * p + offset; }
  Ordered point(const dvec3& p) const;
  double above() const { return out.tooth.crown + 3e-3; }
  Ordered halfspace(const dvec3& normal, const dvec3& on) const;
  Ordered shaft(const glm::dvec2& at, double floor, double radius) const;
  /// An upright block along the line from a to b, with the width `width`, from the height `floor` to above the tooth.
  /// `end_leans`: the wall at `a` leans like the walls beside the line.
  Ordered block(const glm::dvec2& a, const glm::dvec2& b, double floor, double width, bool end_leans = false) const;
  /// Adds an upright slot with round ends to the target shape. A round bur of the slot's width can cut it.
  void slot(const glm::dvec2& a, const glm::dvec2& b, double floor, double width);
  /// Adds a box-shaped cavity, open towards the neighbouring tooth (side 1: mesial, -1: distal), with round corners at
  /// u = `axial`.
  void box(double side, double axial, double middle, double width, double floor);
  /// Adds a neighbouring tooth: the tooth itself, mirrored at its contact point. Behind the canine, the mirror
  /// plane passes through the middle of Monson's sphere, so that the neighbour stands on this sphere too.
  void add_neighbour(double side);
  /// Height w of the tooth's surface at (u, v), m.
  double surface(const glm::dvec2& at) const;
  /// Adds a lesion as deep as the parameter "icdas" demands below the middle of its line, but at most `deepest` (m).
  /// Sets this parameter to the code of the lesion's depth.
  Lesion& add_lesion(Lesion lesion, double deepest);
};

/// Frame W: point at the cusps' tops, as in the shipped exercises, m.
inline constexpr dvec3 kTop{6.9e-3, 5.5e-3, 20.0e-3};

/// Radius of the corners of a box-shaped cavity, m.
inline constexpr double kCorner = 0.65e-3;

/// Thickness of the enamel below the point p of the surface in the direction `down`, and of the dentin from there to
/// the pulp or to the place nearest to it, m (tooth's frame).
struct Layers {
  double enamel = 0, dentin = 0;
};
Layers layers_below(const CaseTooth& tooth, const dvec3& p, const dvec3& down);

/// Depth of a lesion with the ICDAS code 1 to 6, m. `within`: 0 to 1, from the code's least to its largest depth.
double lesion_depth(int icdas, double within, const Layers& layers);
/// The ICDAS code, 1 to 6, of a lesion of this depth (m).
int icdas_of(double depth, const Layers& layers);

/// Adds what the family's recipe makes: lesions, ideal shape, neighbours. Throws RunFailure if the tooth does not suit.
void apply_recipe(Draft& draft);

/// Labels the lesions, and the filling of a family with the key "filled". The tissue is in the tooth's frame.
void apply_lesions(Draft& draft);
/// The tissue rotated by quarter turns.
haptics::DenseTissue turned(const haptics::DenseTissue& tissue, const glm::dmat3& turn);
/// Throws RunFailure if tooth or lesions consist of several pieces, or if too little tissue covers the pulp.
void check_tissue(const Draft& draft);

}  // namespace typodont
