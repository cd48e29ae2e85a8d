// Reads single values from JSON text in real time: builds no tree, never allocates, accepts any input.
#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

namespace typodont::haptics {

/// One value in a JSON text. Functions return nullopt if it is missing or malformed.
class JsonText {
 public:
  explicit JsonText(std::string_view text) : text_(text) {}

  /// Returns the value of a key of this object.
  std::optional<JsonText> get(std::string_view key) const noexcept {
    std::size_t at = skip_space(0);
    if (at >= text_.size() || text_[at] != '{') return std::nullopt;
    ++at;
    for (;;) {
      at = skip_space(at);
      const std::size_t name_end = end_of_value(at);
      if (name_end == kBad || text_[at] != '"') return std::nullopt;
      const std::string_view name = text_.substr(at + 1, name_end - at - 2);
      at = skip_space(name_end);
      if (at >= text_.size() || text_[at] != ':') return std::nullopt;
      at = skip_space(at + 1);
      const std::size_t end = end_of_value(at);
      if (end == kBad) return std::nullopt;
      if (name == key) return JsonText(text_.substr(at, end - at));
      at = skip_space(end);
      if (at >= text_.size() || text_[at] != ',') return std::nullopt;
      ++at;
    }
  }
  /// Returns the first element of this array.
  std::optional<JsonText> first() const noexcept {
    std::size_t at = skip_space(0);
    if (at >= text_.size() || text_[at] != '[') return std::nullopt;
    at = skip_space(at + 1);
    const std::size_t end = end_of_value(at);
    if (end == kBad) return std::nullopt;
    return JsonText(text_.substr(at, end - at));
  }
  std::optional<double> number() const noexcept {
    double value = 0;
    const char* const end = text_.data() + text_.size();
    const auto [at, error] = std::from_chars(text_.data(), end, value);
    if (error != std::errc() || at != end || !std::isfinite(value)) return std::nullopt;
    return value;
  }
  /// Returns the string without its quotes. Escapes are not decoded.
  std::optional<std::string_view> string() const noexcept {
    if (text_.size() < 2 || text_.front() != '"') return std::nullopt;
    return text_.substr(1, text_.size() - 2);
  }
  bool is(std::string_view literal) const noexcept { return text_ == literal; }

 private:
  static constexpr std::size_t kBad = static_cast<std::size_t>(-1);

  std::size_t skip_space(std::size_t at) const noexcept {
    while (at < text_.size() && (text_[at] == ' ' || text_[at] == '\n' || text_[at] == '\t' || text_[at] == '\r')) ++at;
    return at;
  }
  std::size_t end_of_string(std::size_t at) const noexcept {
    for (++at; at < text_.size(); ++at) {
      if (text_[at] == '\\')
        ++at;
      else if (text_[at] == '"')
        return at + 1;
    }
    return kBad;
  }
  std::size_t end_of_value(std::size_t at) const noexcept {
    if (at >= text_.size()) return kBad;
    if (text_[at] == '"') return end_of_string(at);
    if (text_[at] == '{' || text_[at] == '[') {
      int depth = 0;
      while (at < text_.size()) {
        const char c = text_[at];
        if (c == '"') {
          at = end_of_string(at);
          if (at == kBad) return kBad;
          continue;
        }
        if (c == '{' || c == '[') ++depth;
        if ((c == '}' || c == ']') && --depth == 0) return at + 1;
        ++at;
      }
      return kBad;
    }
    const std::size_t start = at;
    while (at < text_.size() && text_[at] != ',' && text_[at] != '}' && text_[at] != ']' && text_[at] != ' ' &&
           text_[at] != '\n' && text_[at] != '\r' && text_[at] != '\t') {
      ++at;
    }
    return at > start ? at : kBad;
  }

  std::string_view text_;
};

}  // namespace typodont::haptics
