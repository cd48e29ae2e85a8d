// The keys of a JSON object, each declared once: the declaration reads files, fills tables in docs/, and gives editors
// a JSON Schema. Not for real-time loops.
#pragma once

#include <concepts>
#include <initializer_list>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/json.h"

namespace typodont {

/// Range of numbers that a file may contain, and the SI value of the number 1 in the file (`unit`).
struct Range {
  double min = -std::numeric_limits<double>::infinity(), max = std::numeric_limits<double>::infinity();
  double unit = 1;
};

/// Default for a documented variable whose default is no number; the text `meaning` then states it in words.
inline constexpr double kNoDefault = std::numeric_limits<double>::quiet_NaN();

/// The type of a key's value, as text for the tables and as JSON Schema. In `schema`, "$object" stands for the schema
/// of an object's keys.
struct Form {
  std::string_view table, schema = "{}";
};
inline constexpr Form kText{"text", R"({"type": "string"})"}, kName{"name", kText.schema}, kFile{"file", kText.schema},
    kNames{"list of names", R"({"type": "array", "items": {"type": "string"}})"},
    kFlag{"true or false", R"({"type": "boolean"})"}, kNumber{"number", R"({"type": "number"})"},
    kNumbers{"list of numbers", R"({"type": "array", "items": {"type": "number"}})"},
    kList{"list", R"({"type": "array"})"}, kPoints{"list of points", kList.schema},
    kPair{"two numbers", R"({"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2})"},
    kAnyObject{"object", R"({"type": "object"})"}, kObject{"object", R"("$object")"},
    kNameOrObject{"name or object", R"({"anyOf": [{"type": "string"}, "$object"]})"},
    kNamesOrObjects{"list of names or objects",
                    R"({"type": "array", "items": {"anyOf": [{"type": "string"}, "$object"]}})"},
    // Solids of haptics/solid.h. An object with such a key also defines "solid" (Keys::define).
    kSolid{"solid", R"({"$ref": "#/$defs/solid"})"},
    kSolids{"list of solids", R"({"type": "array", "items": {"$ref": "#/$defs/solid"}})"},
    kObjects{"list of objects", R"({"type": "array", "items": "$object"})"},
    kPoint{"[x, y, z]", R"({"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3})"},
    kBox{"[[x0, y0, z0], [x1, y1, z1]]", R"({"type": "array", "minItems": 2, "maxItems": 2})"},
    kThree{"three numbers", kPoint.schema}, kDirection{"direction", kPoint.schema}, kColour{"colour", kPoint.schema},
    kQuaternion{"[w, x, y, z]", R"({"type": "array", "items": {"type": "number"}, "minItems": 4, "maxItems": 4})"};

/// A key as a row of a table; `schema`: JSON Schema of its value. Without schema: a definition (Keys::define).
struct KeyRow {
  std::string key, value, meaning, schema;
  bool required = false;
  int alternative = 0;       // number of Keys::alternative() before this key
  std::vector<KeyRow> keys;  // keys of the value: of an object, or of each object in a list
};

/// A key's name. A file may omit the key, unless must() created this object.
struct Key {
  std::string_view name;
  bool required = false;
  Key(const char* text) : name(text) {}
};
inline Key must(const char* name) {
  Key key(name);
  key.required = true;
  return key;
}

/// Reads the keys of an object from a file, or lists them for documentation. A function that describes the object calls
/// operator() once for each key. A variable whose key is absent keeps its value. Throws Error.
class Keys {
 public:
  Keys() = default;                                           // an object without keys
  explicit Keys(const Json& json) : json_(json) {}            // reads the object, ignores its other keys
  Keys(const Json& json, const Keys& known);                  // reads the object; an error if it has other keys
  explicit Keys(std::vector<KeyRow>& rows) : rows_(&rows) {}  // lists the keys

  void operator()(Key key, double& value, const Range& range, std::string_view meaning);
  void operator()(Key key, std::optional<double>& value, const Range& range, std::string_view meaning);
  template <std::integral T>
  void operator()(Key key, T& value, const Range& range, std::string_view meaning) {
    value = static_cast<T>(integer(key, static_cast<long long>(value), range, meaning));
  }
  void operator()(Key key, bool& value, std::string_view meaning);
  void operator()(Key key, std::string& value, std::string_view meaning);
  /// Reads one of `names`. Without the key, the text stays.
  void operator()(Key key, std::string& value, std::span<const std::string_view> names, std::string_view meaning);
  void operator()(Key key, dvec3& value, double unit, std::string_view meaning);
  /// Reads a vector with `read`: read_direction, read_color, or a function for directions with its own message.
  void operator()(Key key, dvec3& value, dvec3 (*read)(const Json&), std::string_view meaning);
  /// Reads an enumerator. The file contains one of `names`, which have the order of the enumerators.
  template <class E>
  requires std::is_enum_v<E>
  void operator()(Key key, E& value, std::span<const std::string_view> names, std::string_view meaning) {
    value = static_cast<E>(choice(key, static_cast<std::size_t>(value), names, meaning));
  }
  template <class E>
  requires std::is_enum_v<E>
  void operator()(Key key, E& value, std::initializer_list<std::string_view> names, std::string_view meaning) {
    (*this)(key, value, std::span(names.begin(), names.size()), meaning);
  }
  /// Declares a key for any other type of value. Returns its JSON, which the caller reads; empty: nothing to read.
  std::optional<Json> operator()(Key key, const Form& form, std::string_view meaning);
  /// Declares a key whose value may be an object, and returns its JSON; the function `of` describes the object's keys.
  template <std::invocable<Keys&> Of>
  std::optional<Json> operator()(Key key, const Form& form, Of&& of, std::string_view meaning);
  // Declare a key whose value is an object that the function `of` describes, or a list of such objects.
  template <std::invocable<Keys&> Of>
  void operator()(Key key, Of&& of, std::string_view meaning);
  template <class T, std::invocable<Keys&, T&> Of>
  void operator()(Key key, T& value, Of&& of, std::string_view meaning) {
    (*this)(
        key, [&](Keys& keys) { of(keys, value); }, meaning);
  }
  template <class T, std::invocable<Keys&, T&> Of>
  void operator()(Key key, std::optional<T>& value, Of&& of, std::string_view meaning);
  template <class T, std::invocable<Keys&, T&> Of>
  void operator()(Key key, std::vector<T>& values, Of&& of, std::string_view meaning);
  /// Allows a key that this program does not read, such as "source".
  void ignore(Key key) { (*this)(key, Form{}, ""); }
  /// Begins an alternative: an object has keys of only one of them, besides the keys before the first alternative.
  void alternative() { ++alternative_, first_ = true; }
  /// Defines an object to which the schemas of forms refer as "#/$defs/NAME". It gets its own table. Call this before
  /// alternative().
  template <std::invocable<Keys&> Of>
  void define(std::string name, Of&& of) {
    if (!rows_) return;
    KeyRow& row = rows_->emplace_back();
    row.key = std::move(name);
    Keys keys(row.keys);
    of(keys);
  }

  /// The JSON object that is read; null while keys are only listed, and in an alternative that the object is not. For
  /// checks that concern several keys.
  const Json* json() const { return json_ && reads() ? &*json_ : nullptr; }

 private:
  bool reads() const { return chosen_ == 0 || alternative_ == 0 || alternative_ == chosen_; }
  std::optional<Json> find(Key key);
  KeyRow* list(Key key, std::string value, std::string_view meaning, std::string schema);
  long long integer(Key key, long long value, const Range& range, std::string_view meaning);
  std::size_t choice(Key key, std::size_t chosen, std::span<const std::string_view> names, std::string_view meaning);

  std::optional<Json> json_;
  std::vector<KeyRow>* rows_ = nullptr;
  struct Name {
    Key key;
    int alternative;
  };
  std::vector<Name> names_;
  int alternative_ = 0, chosen_ = 0;  // alternatives begun so far; that of the object, 0: reads all
  bool first_ = false;                // true: the next key is the first one of an alternative
};

// Read a unit vector and a colour. Throw Error.
dvec3 read_direction(const Json& json);
dvec3 read_color(const Json& json);

/// Reads an object. `describe(Keys&)` is called twice: first only to collect the names of the object's keys.
template <std::invocable<Keys&> Describe>
void read_keys(const Json& json, Describe&& describe) {
  Keys known;
  describe(known);
  Keys keys(json, known);
  describe(keys);
}

template <class T>
T read_keys(const Json& json, void (*describe)(Keys&, T&)) {
  T value{};
  read_keys(json, [&](Keys& keys) { describe(keys, value); });
  return value;
}

/// Tables of keys in Markdown, one for each object. `name`: name of the outermost object.
std::string key_tables(std::string_view name, const std::vector<KeyRow>& rows);
/// A JSON Schema of the object.
std::string key_schema(const std::vector<KeyRow>& rows);

template <std::invocable<Keys&> Of>
std::optional<Json> Keys::operator()(Key key, const Form& form, Of&& of, std::string_view meaning) {
  if (KeyRow* row = list(key, std::string(form.table), meaning, std::string(form.schema))) {
    Keys keys(row->keys);
    of(keys);
  }
  return find(key);
}

template <std::invocable<Keys&> Of>
void Keys::operator()(Key key, Of&& of, std::string_view meaning) {
  if (const auto json = (*this)(key, kObject, of, meaning)) read_keys(*json, of);
}

template <class T, std::invocable<Keys&, T&> Of>
void Keys::operator()(Key key, std::optional<T>& value, Of&& of, std::string_view meaning) {
  T read{};
  const auto describe = [&](Keys& keys) { of(keys, read); };
  if (const auto json = (*this)(key, kObject, describe, meaning)) {
    read_keys(*json, describe);
    value = std::move(read);
  }
}

template <class T, std::invocable<Keys&, T&> Of>
void Keys::operator()(Key key, std::vector<T>& values, Of&& of, std::string_view meaning) {
  const auto any = [&](Keys& keys) {
    T value{};
    of(keys, value);
  };
  const auto json = (*this)(key, kObjects, any, meaning);
  if (!json) return;
  for (const Json& item : json->items()) {
    T& value = values.emplace_back();
    read_keys(item, [&](Keys& keys) { of(keys, value); });
  }
}

}  // namespace typodont
