#include "engine/base/keys.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <regex>

namespace typodont {

namespace {

using Schema = nlohmann::ordered_json;

std::string number(double value, double scale = 1e9) {
  return fmt::format("{}{}", value < 0 ? "−" : "", std::round(std::abs(value) * scale) / scale);
}

/// Text for a table: the valid range, and the default if it is in this range.
std::string text_of(const Range& range, double fallback, bool required) {
  const bool low = std::isfinite(range.min), high = std::isfinite(range.max);
  std::string text = low && high
                         ? fmt::format("{}{}{}", number(range.min), range.min < 0 ? " to " : "–", number(range.max))
                     : low ? fmt::format("at least {}", number(range.min))
                           : "number";
  if (!required && fallback >= range.min && fallback <= range.max)
    text += fmt::format("; default {}", number(fallback, 1e4));
  return text;
}

std::string schema_of(std::string_view type, const Range& range) {
  Schema schema{{"type", type}};
  if (std::isfinite(range.min)) schema["minimum"] = range.min;
  if (std::isfinite(range.max)) schema["maximum"] = range.max;
  return schema.dump();
}

/// `defs`: receives the definitions.
Schema object_schema(const std::vector<KeyRow>& rows, Schema& defs) {
  static const std::regex links(R"(\[([^\]]*)\]\([^)]*\)|`)");  // Markdown links, and the marks ` around code
  const auto schema_of = [&](int alternative) {
    Schema schema{{"type", "object"}, {"properties", Schema::object()}, {"additionalProperties", false}};
    for (const KeyRow& row : rows) {
      if (row.schema.empty()) defs[row.key] = object_schema(row.keys, defs);
      if (row.schema.empty() || (row.alternative != 0 && row.alternative != alternative)) continue;
      std::string text = row.schema;
      if (const std::size_t at = text.find("\"$object\""); at != std::string::npos)
        text.replace(at, 9, object_schema(row.keys, defs).dump());
      Schema& value = schema["properties"][row.key] = Schema::parse(text);
      if (!row.meaning.empty()) value["description"] = std::regex_replace(row.meaning, links, "$1");
      if (row.required) schema["required"].push_back(row.key);
    }
    return schema;
  };
  const int alternatives = rows.empty() ? 0 : rows.back().alternative;
  if (alternatives == 0) return schema_of(0);
  Schema any;
  for (int i = 1; i <= alternatives; ++i) any["anyOf"].push_back(schema_of(i));
  return any;
}

}  // namespace

Keys::Keys(const Json& json, const Keys& known) : json_(json) {
  std::vector<std::string_view> names, firsts;  // firsts: the first key of each alternative
  for (const auto& [key, alternative] : known.names_) {
    names.push_back(key.name);
    if (static_cast<std::size_t>(alternative) > firsts.size()) firsts.push_back(key.name);
  }
  if (firsts.empty() || json.is_object()) json.allow_only(names);
  for (const auto& [key, alternative] : known.names_) {
    if (alternative == 0 || !json.has(key.name)) continue;
    if (chosen_ == 0) chosen_ = alternative;
    if (alternative != chosen_)
      json[key.name].fail(fmt::format("{} beside {}", key.name, firsts[static_cast<std::size_t>(chosen_ - 1)]),
                          "one of them");
  }
  // Without any of the keys, the object is the alternative that requires none.
  for (int i = 1; i <= known.alternative_ && chosen_ == 0 && json.is_object(); ++i)
    if (std::ranges::none_of(known.names_, [&](const Name& n) { return n.alternative == i && n.key.required; }))
      chosen_ = i;
  if (!firsts.empty() && chosen_ == 0) json.fail(fmt::format("an object with one of {}", fmt::join(firsts, ", ")));
}

std::optional<Json> Keys::find(Key key) {
  names_.push_back({key, alternative_});
  first_ = false;
  if (!json()) return std::nullopt;
  return key.required ? (*json_)[key.name] : json_->find(key.name);
}

KeyRow* Keys::list(Key key, std::string value, std::string_view meaning, std::string schema) {
  if (!rows_) return nullptr;
  if (key.required && !first_) value += "; required";
  return &rows_->emplace_back(
      KeyRow{std::string(key.name), value, std::string(meaning), schema, key.required, alternative_, {}});
}

void Keys::operator()(Key key, double& value, const Range& range, std::string_view meaning) {
  if (rows_) list(key, text_of(range, value / range.unit, key.required), meaning, schema_of("number", range));
  if (const auto json = find(key)) value = json->number(range.min, range.max) * range.unit;
}

long long Keys::integer(Key key, long long value, const Range& range, std::string_view meaning) {
  if (rows_) list(key, text_of(range, static_cast<double>(value), key.required), meaning, schema_of("integer", range));
  constexpr long long kMax = std::numeric_limits<long long>::max();
  const auto json = find(key);
  if (!json) return value;
  return json->integer(static_cast<long long>(range.min),
                       std::isinf(range.max) ? kMax : static_cast<long long>(range.max));
}

void Keys::operator()(Key key, std::optional<double>& value, const Range& range, std::string_view meaning) {
  double number = value.value_or(kNoDefault);
  (*this)(key, number, range, meaning);
  if (!std::isnan(number)) value = number;
}

void Keys::operator()(Key key, bool& value, std::string_view meaning) {
  if (rows_) list(key, fmt::format("default {}", value), meaning, R"({"type": "boolean"})");
  if (const auto json = find(key)) value = json->boolean();
}

void Keys::operator()(Key key, std::string& value, std::string_view meaning) {
  if (rows_) list(key, "text", meaning, R"({"type": "string"})");
  if (const auto json = find(key)) value = json->string();
}

void Keys::operator()(Key key, std::string& value, std::span<const std::string_view> names, std::string_view meaning) {
  const std::size_t chosen = choice(key, names.size(), names, meaning);
  if (chosen < names.size()) value = names[chosen];
}

void Keys::operator()(Key key, dvec3& value, double unit, std::string_view meaning) {
  if (rows_) {
    const dvec3 v = value / unit;
    const bool stated = key.required || std::isnan(v.x);
    const std::string text = fmt::format("default [{}, {}, {}]", number(v.x), number(v.y), number(v.z));
    list(key, stated ? "[x, y, z]" : text, meaning, std::string(kDirection.schema));
  }
  if (const auto json = find(key)) value = json->vec3() * unit;
}

void Keys::operator()(Key key, dvec3& value, dvec3 (*read)(const Json&), std::string_view meaning) {
  if (const auto json = (*this)(key, read == read_color ? kColour : kDirection, meaning)) value = read(*json);
}

std::optional<Json> Keys::operator()(Key key, const Form& form, std::string_view meaning) {
  list(key, std::string(form.table), meaning, std::string(form.schema));
  return find(key);
}

std::size_t Keys::choice(Key key, std::size_t chosen, std::span<const std::string_view> names,
                         std::string_view meaning) {
  if (rows_) {
    std::string value = fmt::format("`\"{}\"`", fmt::join(names, "\"`, `\""));
    if (!key.required && chosen < names.size()) value += fmt::format("; default `\"{}\"`", names[chosen]);
    list(key, value, meaning, Schema{{"enum", std::vector<std::string>(names.begin(), names.end())}}.dump());
  }
  const auto json = find(key);
  if (!json) return chosen;
  const auto named = std::find(names.begin(), names.end(), json->string());
  if (named == names.end())
    json->fail(fmt::format("{} or {}", fmt::join(names.first(names.size() - 1), ", "), names.back()));
  return static_cast<std::size_t>(named - names.begin());
}

dvec3 read_direction(const Json& json) {
  const dvec3 v = json.vec3();
  if (glm::length(v) < 1e-9) json.fail("a direction, not zero");
  return glm::normalize(v);
}

dvec3 read_color(const Json& json) {
  const dvec3 color = json.vec3();
  if (glm::any(glm::lessThan(color, dvec3(0))) || glm::any(glm::greaterThan(color, dvec3(1))))
    json.fail("three numbers from 0 to 1 (sRGB)");
  return color;
}

std::string key_tables(std::string_view name, const std::vector<KeyRow>& rows) {
  constexpr std::size_t kFew = 5;  // an object with at most so many keys is listed in the table of the outer object
  std::string text = fmt::format("{}:\n|key|value|meaning|\n|---|---|---|\n", name), nested;
  const auto add = [&](const KeyRow& row, std::string_view outer) {
    if (!row.meaning.empty()) text += fmt::format("|`{}{}`|{}|{}|\n", outer, row.key, row.value, row.meaning);
  };
  const auto lists = [](const KeyRow& row) {
    return std::ranges::any_of(row.keys, [](const KeyRow& inner) { return !inner.meaning.empty(); });
  };
  for (const KeyRow& row : rows) {
    add(row, "");
    const bool small = !row.meaning.empty() && row.keys.size() <= kFew && std::ranges::none_of(row.keys, lists);
    for (const KeyRow& inner : row.keys)
      if (small) add(inner, row.key + ".");
    if (!small && lists(row)) nested += fmt::format("\n{}", key_tables(fmt::format("{}.{}", name, row.key), row.keys));
  }
  return text + nested;
}

std::string key_schema(const std::vector<KeyRow>& rows) {
  Schema defs, schema = object_schema(rows, defs);
  if (!defs.empty()) schema["$defs"] = std::move(defs);
  schema["$schema"] = "https://json-schema.org/draft/2020-12/schema";
  return schema.dump(2);
}

}  // namespace typodont
