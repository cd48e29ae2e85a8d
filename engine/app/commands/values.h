// Values that several commands print as JSON, or take as text.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/pose.h"
#include "engine/contract/tissue.h"

namespace typodont {

/// The values above 0, divided by `unit`, with the tissue's name and `suffix` as key.
inline nlohmann::ordered_json by_tissue(const PerTissue& values, double unit, std::string_view suffix = "") {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (std::size_t t = 0; t < kTissueCount; ++t)
    if (values[t] > 0) json[std::string(name_of(static_cast<Tissue>(t))).append(suffix)] = values[t] / unit;
  return json;
}

inline nlohmann::ordered_json vec(const dvec3& v, double unit) {
  return {v.x / unit, v.y / unit, v.z / unit};
}

/// Reads `least` to `most` finite numbers from a text such as "1,2.5,-3". Throws Error, which names the option.
inline std::vector<double> numbers(const std::string& text, const char* option, std::size_t least, std::size_t most,
                                   const char* expected) {
  std::vector<double> values;
  const auto fail = [&] { throw Error(option, "", '"' + text + '"', expected); };
  for (const char* p = text.c_str();;) {
    char* end = nullptr;
    values.push_back(std::strtod(p, &end));
    if (end == p || !std::isfinite(values.back()) || (*end != '\0' && *end != ',')) fail();
    if (*end == '\0') break;
    p = end + 1;
  }
  if (values.size() < least || values.size() > most) fail();
  return values;
}

}  // namespace typodont
