#include "engine/app/scene/handpiece_file.h"

#include <fmt/format.h>

#include <cmath>

#include "engine/app/assets.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

constexpr double kWidestHead = 8e-3;  // m, largest head diameter that fits a dental handpiece
// Largest numbers of parts, rings and coloured bands in a handpiece file. They limit the triangles that
// engine/render/handpiece_mesh.h makes.
constexpr std::size_t kMaxParts = 16, kMaxRings = 64, kMaxBands = 16;
constexpr int kMaxCopies = 12;
constexpr double kFarthest = 300;  // mm, largest absolute value of a length or coordinate in a handpiece file

HandpiecePart read_part(const Json& json) {
  json.allow_only({"rings_mm", "smooth", "color", "roughness", "brushed", "metal", "glow", "bands_mm", "knurl_mm",
                   "width", "repeat"});
  HandpiecePart part;
  const Json rings = json["rings_mm"];
  for (const Json& ring : rings.items()) {
    const std::vector<double> v = ring.numbers(3);
    for (const double number : v)
      if (std::abs(number) > kFarthest) ring.fail(fmt::format("numbers up to {:g}", kFarthest));
    if (v[2] < 0) ring.fail("[x, z, radius] with a radius of at least 0");
    part.rings.push_back({v[0] * kMillimetre, v[1] * kMillimetre, v[2] * kMillimetre});
  }
  if (part.rings.size() < 2 || part.rings.size() > kMaxRings)
    rings.fail(fmt::format("{} rings", part.rings.size()), fmt::format("2 to {} rings", kMaxRings));
  double length = 0;  // mm, length of the line through the handpiece's ring centres
  for (std::size_t i = 1; i < part.rings.size(); ++i)
    length += std::hypot(part.rings[i].x - part.rings[i - 1].x, part.rings[i].z - part.rings[i - 1].z) / kMillimetre;
  if (!(length > 0)) rings.fail("rings with one middle", "a path with a length");
  part.smooth = json.boolean_or("smooth", false);
  if (const auto color = json.find("color")) {
    part.color = color->vec3();
    for (int i = 0; i < 3; ++i)
      if (part.color[i] < 0 || part.color[i] > 1) color->fail("three numbers from 0 to 1 (sRGB)");
  }
  part.roughness = json.number_or("roughness", part.roughness, 0.05, 1);
  part.brushed = json.boolean_or("brushed", false);
  part.metal = json.boolean_or("metal", true);
  part.glow = json.number_or("glow", 0, 0, 1);
  const auto range = [&](const Json& item) {
    const std::vector<double> v = item.numbers(2);
    if (!(v[0] >= 0 && v[0] < v[1] && v[1] <= length))
      item.fail(fmt::format("[from, to] with 0 <= from < to <= {:.4g}, the length of the path", length));
    return std::array<double, 2>{v[0] * kMillimetre, v[1] * kMillimetre};
  };
  if (const auto bands = json.find("bands_mm")) {
    for (const Json& band : bands->items()) part.bands.push_back(range(band));
    if (part.bands.size() > kMaxBands) bands->fail(fmt::format("at most {} bands", kMaxBands));
  }
  if (const auto knurl = json.find("knurl_mm")) part.knurl = range(*knurl);
  part.width = json.number_or("width", 1, 0.2, 5);
  if (const auto repeat = json.find("repeat")) part.repeat = static_cast<int>(repeat->integer(1, kMaxCopies));
  return part;
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

Handpiece read_handpiece(const Json& json) {
  json.allow_only({"name", "begins_at", "parts", "source"});
  Handpiece handpiece;
  handpiece.name = json["name"].string();
  const std::string begins = json["begins_at"].string();
  if (begins != "head" && begins != "shank") json["begins_at"].fail("\"head\" or \"shank\"");
  handpiece.from_head = begins == "head";
  const Json parts = json["parts"];
  for (const Json& part : parts.items()) handpiece.parts.push_back(read_part(part));
  if (handpiece.parts.empty() || handpiece.parts.size() > kMaxParts)
    parts.fail(fmt::format("{} parts", handpiece.parts.size()), fmt::format("1 to {} parts", kMaxParts));
  return handpiece;
}

Handpiece load_handpiece(const std::string& name) {
  return read_handpiece(Json::load(named_asset("handpieces", name)));
}

HandpieceView read_handpiece_view(const Json& json) {
  json.allow_only({"shown", "roll_deg"});
  HandpieceView view;
  const std::string shown = json.string_or("shown", "open");
  if (shown != "open" && shown != "solid" && shown != "none") json["shown"].fail("\"open\", \"solid\" or \"none\"");
  view.shown = shown != "none";
  view.open = shown == "open";
  view.roll = json.number_or("roll_deg", view.roll / kDegree, -360, 360) * kDegree;
  return view;
}

}  // namespace typodont
