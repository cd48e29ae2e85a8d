#include "engine/app/scene/ideal.h"

#include "engine/base/keys.h"

namespace typodont {

static void describe_crown(Keys& keys, CrownReduction& crown) {
  keys(must("margin_mm"), crown.margin_height, {-1000, 1000, kMillimetre},
       "height of the chamfer's lowest point along the axis");
  keys(must("chamfer_mm"), crown.chamfer, {0.1, 3, kMillimetre},
       "depth of the walls inside the tooth's outline at this height; above the chamfer, at least this depth is "
       "removed");
  keys(must("chamfer_radius_mm"), crown.chamfer_radius, {0.2, 5, kMillimetre},
       "radius of the chamfer's arc and of the bur's round end");
  keys(must("taper_deg"), crown.taper, {0, 60, kDegree}, "twice the angle between walls and axis");
  keys(must("occlusal_mm"), crown.occlusal, {0.1, 5, kMillimetre},
       "depth removed from the occlusal surface (normal within 60° of the axis)");
  keys("edge_radius_mm", crown.edge_radius, {0, 2, kMillimetre}, "radius of the rounded edges");
}

void describe_ideal(Keys& keys, Ideal& ideal, const haptics::SolidFiles& files) {
  keys.alternative();
  ideal.volume = keys(must("volume"), kFile, "the tissue of a volume file, such as `typodont servo --save` writes");
  keys.alternative();
  ideal.session = keys(must("session"), kFile, "the final tissue of a recording of this scene");
  keys.alternative();
  const auto unprepared = keys(must("unprepared"), Form{"true", R"({"const": true})"},
                               "the tissue before `prepare`: a cavity must be filled to this contour, an added solid "
                               "removed");
  if (unprepared && !(ideal.unprepared = unprepared->boolean())) unprepared->fail("true");
  keys.alternative();
  const auto mesh = [&](Keys& of) {
    ideal.mesh = of(must("file"), kFile, "the mesh");
    of("unit_mm", ideal.mesh_unit, {1e-6, 1e6, kMillimetre}, "length of one unit of the file in millimetres");
  };
  keys(must("mesh"), mesh,
       "the inside of a closed mesh; where the mesh is at most one voxel below the tissue's surface, no cut is "
       "required");
  keys.alternative();
  keys(must("crown"), ideal.crown, describe_crown,
       "a [preparation for a crown](#crown), computed from the tooth's own surface");
  keys.alternative();
  const auto solids = [&](const char* key, std::vector<std::unique_ptr<haptics::Solid>>& to, const char* meaning) {
    if (const auto list = keys(key, kSolids, meaning)) to = haptics::read_solid_list(list->items(), files);
  };
  solids("remove", ideal.remove, "tissue to remove");
  if (const auto names = keys("remove_tissue", kNames, "tissues to remove")) {
    for (const Json& name : names->items()) ideal.remove_tissue.push_back(haptics::read_tissue_name(name));
  }
  keys("grow_mm", ideal.grow, {-5, 5, kMillimetre},
       "layer around `remove` and `remove_tissue` that is removed too. An upright bur cannot reach below an overhang: "
       "name the overhang with `remove`");
  solids("keep", ideal.keep, "tissue that must remain inside `remove`");
  if (keys.json() && ideal.remove.empty() && ideal.remove_tissue.empty())
    keys.json()->fail("an ideal that removes nothing", "remove, remove_tissue, or both");
}

}  // namespace typodont
