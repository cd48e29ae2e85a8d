// SHA-256, for data from outside: nobody can construct other data with the same hash.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>

struct evp_md_ctx_st;

namespace typodont {

class Sha256 {
 public:
  Sha256();
  void bytes(const void* data, std::size_t size) noexcept;
  template <class T>
  void add(const T& number) noexcept {
    static_assert(std::is_arithmetic_v<T>);
    bytes(&number, sizeof number);
  }
  /// Hash of all data added so far.
  std::array<unsigned char, 32> digest() const;
  /// The hash as "sha256:" and 64 hexadecimal digits.
  std::string text() const;
  /// The hash's first eight bytes: key of a cached file.
  std::uint64_t key() const;

 private:
  struct Free {
    void operator()(evp_md_ctx_st* state) const noexcept;
  };
  std::unique_ptr<evp_md_ctx_st, Free> state_;
};

}  // namespace typodont
