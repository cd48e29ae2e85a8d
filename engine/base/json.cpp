#include "engine/base/json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "engine/base/error.h"
#include "engine/base/partial_file.h"

namespace typodont {

using Value = nlohmann::json;

struct Json::Document {
  std::filesystem::path file;
  Value root;
};

namespace {

const Value& as_value(const void* value) {
  return *static_cast<const Value*>(value);
}

std::string shorten(std::string text) {
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return text;
}

std::size_t line_of(std::string_view text, std::size_t byte) {
  return 1 + static_cast<std::size_t>(std::count(text.begin(), text.begin() + std::min(byte, text.size()), '\n'));
}

Value parse_strictly(std::string_view text, std::string_view name) {
  // nlohmann keeps the last of two equal keys; a scene with two "tool" entries is a mistake worth a message.
  std::vector<std::set<std::string>> open;
  std::string duplicate;
  const auto watch = [&](int, Value::parse_event_t event, Value& parsed) {
    if (event == Value::parse_event_t::object_start) open.emplace_back();
    if (event == Value::parse_event_t::object_end) open.pop_back();
    if (event == Value::parse_event_t::key && !open.back().insert(parsed.get<std::string>()).second) {
      duplicate = parsed.get<std::string>();
    }
    return true;
  };
  // A hostile file can nest so deep that the recursive destructor overflows the stack.
  int depth = 0;
  for (const char c : text) {
    if (c == '[' || c == '{') ++depth;
    if (c == ']' || c == '}') --depth;
    if (depth > 200) throw Error(name, "", "more than 200 nested levels", "a flat document");
  }
  try {
    Value root = Value::parse(text, watch);
    if (!duplicate.empty()) throw Error(name, fmt::format("\"{}\"", duplicate), "the key twice", "each key once");
    return root;
  } catch (const Value::parse_error& e) {
    throw Error(name, fmt::format("line {}", line_of(text, e.byte)), "text that is not JSON", "valid JSON");
  } catch (const Value::exception& e) {
    throw Error(name, "", e.what(), "valid JSON");
  }
}

}  // namespace

Json::Json(std::shared_ptr<const Document> document, const void* value, std::string path)
    : document_(std::move(document)), value_(value), path_(std::move(path)) {}

Json Json::load(const std::filesystem::path& file) {
  std::error_code code;
  if (std::filesystem::is_directory(file, code)) throw Error(file.string(), "", "a directory", "a JSON file");
  std::ifstream in(file, std::ios::binary);
  if (!in) throw Error(file.string(), "", std::strerror(errno), "a readable file");
  std::ostringstream text;
  text << in.rdbuf();
  auto document = std::make_shared<Document>();
  document->file = file;
  document->root = parse_strictly(text.str(), file.string());
  return Json(document, &document->root, "");
}

Json Json::parse(std::string_view text, std::string_view name) {
  auto document = std::make_shared<Document>();
  document->file = std::string(name);
  document->root = parse_strictly(text, name);
  return Json(document, &document->root, "");
}

bool Json::is_object() const {
  return as_value(value_).is_object();
}
bool Json::is_array() const {
  return as_value(value_).is_array();
}
bool Json::is_string() const {
  return as_value(value_).is_string();
}
bool Json::is_number() const {
  return as_value(value_).is_number();
}

bool Json::has(std::string_view key) const {
  return is_object() && as_value(value_).contains(std::string(key));
}

Json Json::operator[](std::string_view key) const {
  if (!is_object()) fail("an object");
  auto found = find(key);
  if (!found) {
    throw Error(document_->file.string(),
                path_.empty() ? fmt::format("\"{}\"", key) : fmt::format("\"{}.{}\"", path_, key), "nothing",
                "this key");
  }
  return *found;
}

std::optional<Json> Json::find(std::string_view key) const {
  const Value& v = as_value(value_);
  if (!v.is_object()) fail("an object");
  const auto it = v.find(std::string(key));
  if (it == v.end()) return std::nullopt;
  return Json(document_, &*it, path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key));
}

std::vector<Json> Json::items() const {
  const Value& v = as_value(value_);
  if (!v.is_array()) fail("an array");
  std::vector<Json> result;
  for (std::size_t i = 0; i < v.size(); ++i) result.push_back(Json(document_, &v[i], fmt::format("{}[{}]", path_, i)));
  return result;
}

std::vector<std::string> Json::keys() const {
  if (!is_object()) fail("an object");
  std::vector<std::string> result;
  for (const auto& [key, value] : as_value(value_).items()) result.push_back(key);
  return result;
}

void Json::allow_only(std::initializer_list<std::string_view> allowed) const {
  if (!is_object()) fail("an object");
  for (const std::string& key : keys()) {
    if (std::find(allowed.begin(), allowed.end(), key) != allowed.end()) continue;
    throw Error(document_->file.string(),
                path_.empty() ? fmt::format("\"{}\"", key) : fmt::format("\"{}.{}\"", path_, key), "an unknown key",
                fmt::format("one of {}", fmt::join(allowed, ", ")));
  }
}

double Json::number(double min, double max) const {
  const Value& v = as_value(value_);
  const double x = v.is_number() ? v.get<double>() : std::nan("");
  if (!std::isfinite(x)) fail("a number");
  if (x < min || x > max) {
    if (std::isinf(max)) fail(fmt::format("at least {}", min));
    if (std::isinf(min)) fail(fmt::format("at most {}", max));
    fail(fmt::format("{} to {}", min, max));
  }
  return x;
}

long long Json::integer(long long min, long long max) const {
  const Value& v = as_value(value_);
  if (!v.is_number_integer()) fail("an integer");
  if (v.is_number_unsigned() && v.get<unsigned long long>() > static_cast<unsigned long long>(max)) {
    fail(fmt::format("{} to {}", min, max));
  }
  const long long x = v.get<long long>();
  if (x < min || x > max) fail(fmt::format("{} to {}", min, max));
  return x;
}

bool Json::boolean() const {
  if (!as_value(value_).is_boolean()) fail("true or false");
  return as_value(value_).get<bool>();
}

std::string Json::string() const {
  if (!is_string()) fail("a string");
  return as_value(value_).get<std::string>();
}

std::vector<double> Json::numbers(std::size_t count) const {
  if (!is_array() || as_value(value_).size() != count) fail(fmt::format("an array of {} numbers", count));
  std::vector<double> result;
  for (const Json& item : items()) result.push_back(item.number());
  return result;
}

dvec3 Json::vec3() const {
  const auto v = numbers(3);
  return {v[0], v[1], v[2]};
}

double Json::number_or(std::string_view key, double fallback, double min, double max) const {
  const auto v = find(key);
  return v ? v->number(min, max) : fallback;
}

bool Json::boolean_or(std::string_view key, bool fallback) const {
  const auto v = find(key);
  return v ? v->boolean() : fallback;
}

std::string Json::string_or(std::string_view key, std::string_view fallback) const {
  const auto v = find(key);
  return v ? v->string() : std::string(fallback);
}

void Json::fail(std::string_view expected) const {
  fail(text(), expected);
}

void Json::fail(std::string_view found, std::string_view expected) const {
  throw Error(document_->file.string(), path_.empty() ? std::string() : fmt::format("\"{}\"", path_),
              shorten(std::string(found)), expected);
}

const std::filesystem::path& Json::file() const {
  return document_->file;
}

std::string Json::text() const {
  return as_value(value_).dump(-1, ' ', false, Value::error_handler_t::replace);
}

void write_file_atomically(const std::filesystem::path& file, std::string_view bytes) {
  PartialFile partial(file);
  errno = 0;
  std::ofstream out(partial.path(), std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) throw Error(file.string(), "", errno ? std::strerror(errno) : "a short write", "a writable place");
  partial.keep();
}

}  // namespace typodont
