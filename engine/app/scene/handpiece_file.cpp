#include "engine/app/scene/handpiece_file.h"

#include <fmt/format.h>

#include <cmath>

#include "engine/app/assets.h"
#include "engine/base/keys.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

constexpr double kWidestHead = 8e-3;  // m, largest head diameter that fits a dental handpiece
// Largest numbers of parts, rings and coloured bands in a handpiece file. They limit the triangles that
// engine/render/handpiece_mesh.h makes.
constexpr std::size_t kMaxParts = 16, kMaxRings = 64, kMaxBands = 16;
constexpr int kMaxCopies = 12;
constexpr double kFarthest = 300;  // mm, largest absolute value of a length or coordinate in a handpiece file

constexpr Form kRange{"[from, to]", kPair.schema};

/// Reads the rings. Returns the length of the line through their centres, mm.
double read_rings(const Json& rings, HandpiecePart& part) {
  for (const Json& ring : rings.items()) {
    const std::vector<double> v = ring.numbers(3);
    for (const double number : v)
      if (std::abs(number) > kFarthest) ring.fail(fmt::format("numbers up to {:g}", kFarthest));
    if (v[2] < 0) ring.fail("[x, z, radius] with a radius of at least 0");
    part.rings.push_back({v[0] * kMillimetre, v[1] * kMillimetre, v[2] * kMillimetre});
  }
  if (part.rings.size() < 2 || part.rings.size() > kMaxRings)
    rings.fail(fmt::format("{} rings", part.rings.size()), fmt::format("2 to {} rings", kMaxRings));
  double length = 0;
  for (std::size_t i = 1; i < part.rings.size(); ++i)
    length += std::hypot(part.rings[i].x - part.rings[i - 1].x, part.rings[i].z - part.rings[i - 1].z) / kMillimetre;
  if (!(length > 0)) rings.fail("rings with one middle", "a path with a length");
  return length;
}

std::array<double, 2> read_range(const Json& json, double length) {
  const std::vector<double> v = json.numbers(2);
  if (!(v[0] >= 0 && v[0] < v[1] && v[1] <= length))
    json.fail(fmt::format("[from, to] with 0 <= from < to <= {:.4g}, the length of the path", length));
  return {v[0] * kMillimetre, v[1] * kMillimetre};
}

void describe_part(Keys& keys, HandpiecePart& part) {
  double length = 0;
  if (const auto rings = keys(must("rings_mm"), kList,
                              "2 to 64 rings `[x, z, radius]` of a tube with closed ends in the plane y = 0, from the "
                              "tool outwards. No number may exceed 300"))
    length = read_rings(*rings, part);
  keys("smooth", part.smooth, "true: the tube is a smooth curve through the rings");
  keys("color", part.color, read_color, "colour; default [0.75, 0.76, 0.78]");
  keys("roughness", part.roughness, {0.05, 1}, "roughness of the surface");
  keys("brushed", part.brushed, "true: grooves around the part");
  keys("metal", part.metal, "false: plastic or rubber");
  keys("glow", part.glow, {0, 1}, "light that the part emits");
  if (const auto bands = keys("bands_mm", kList, "at most 16 black bands `[from, to]`, along the path of the tube")) {
    for (const Json& band : bands->items()) part.bands.push_back(read_range(band, length));
    if (part.bands.size() > kMaxBands) bands->fail(fmt::format("at most {} bands", kMaxBands));
  }
  if (const auto knurl = keys("knurl_mm", kRange, "a knurl, along the path of the tube"))
    part.knurl = read_range(*knurl, length);
  keys("width", part.width, {0.2, 5}, "factor of the radius along y");
  keys("repeat", part.repeat, {1, kMaxCopies}, "number of copies around the axis of the tool");
}

/// The shank type that an ISO 6360 code states in its second group of digits, for example 314 in "500 314 001001 012".
/// Returns 0 if the code has no second group.
int shank_type(const std::string& iso_code) {
  const std::size_t space = iso_code.find(' ');
  return space == std::string::npos ? 0 : std::atoi(iso_code.c_str() + space);
}

/// The name of the handpiece that holds the tool, or "none". handpiece_name() states the rules.
std::string stated_or_usual(const haptics::Tool& tool, const haptics::Spindle& spindle) {
  if (!tool.handpiece.empty()) return tool.handpiece;
  if (tool.diameter > kWidestHead) return "none";
  if (tool.implant && tool.implant->kind == haptics::ImplantToolKind::kGauge) return "gauge";
  if (tool.implant && tool.implant->by_hand) return "ratchet";
  if (!tool.turns() && !tool.implant) return "handle";
  const int shank = shank_type(tool.iso_code);
  if (shank >= 100 && shank < 200) return "straight";
  if (!spindle.handpiece.empty()) return spindle.handpiece;
  return shank >= 200 && shank < 300 ? "contra_angle" : "turbine";
}

}  // namespace

std::string handpiece_name(const haptics::Tool& tool, const haptics::Spindle& spindle) {
  const std::string name = stated_or_usual(tool, spindle);
  return name == "none" ? "" : name;
}

void describe_handpiece(Keys& keys, Handpiece& handpiece) {
  keys(must("name"), handpiece.name, "name of the handpiece");
  if (const auto begins =
          keys(must("begins_at"), kName, "`\"shank\"` or `\"head\"`: origin of the handpiece's frame")) {
    handpiece.from_head = begins->string() == "head";
    if (!handpiece.from_head && begins->string() != "shank") begins->fail("\"head\" or \"shank\"");
  }
  keys(must("parts"), handpiece.parts, describe_part, "1 to 16 tubes");
  keys.ignore("source");
  if (keys.json() && (handpiece.parts.empty() || handpiece.parts.size() > kMaxParts)) {
    (*keys.json())["parts"].fail(fmt::format("{} parts", handpiece.parts.size()),
                                 fmt::format("1 to {} parts", kMaxParts));
  }
}

Handpiece read_handpiece(const Json& json) {
  return read_keys(json, describe_handpiece);
}

Handpiece load_handpiece(const std::string& name) {
  return read_handpiece(Json::load(named_asset("handpieces", name)));
}

void describe_handpiece_view(Keys& keys, HandpieceView& view) {
  if (const auto json = keys("shown", kName,
                             "`\"open\"` (default): the picture omits the part of the handpiece that hides the working "
                             "point of the tool from an eye. `\"solid\"`: the complete handpiece. `\"none\"`: only the "
                             "tool")) {
    const std::string shown = json->string();
    if (shown != "open" && shown != "solid" && shown != "none") json->fail("\"open\", \"solid\" or \"none\"");
    view.shown = shown != "none";
    view.open = shown == "open";
  }
  keys("roll_deg", view.roll, {-360, 360, kDegree},
       "angle by which the handpiece is rotated about the z axis of the tool. At 0°, the body of the handpiece points "
       "along the tool's x axis");
}

}  // namespace typodont
