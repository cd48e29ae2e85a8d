#include "engine/base/sha256.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <cstring>
#include <new>

namespace typodont {

void Sha256::Free::operator()(evp_md_ctx_st* state) const noexcept {
  EVP_MD_CTX_free(state);
}

Sha256::Sha256() : state_(EVP_MD_CTX_new()) {
  if (!state_ || EVP_DigestInit_ex(state_.get(), EVP_sha256(), nullptr) != 1) throw std::bad_alloc();
}

void Sha256::bytes(const void* data, std::size_t size) noexcept {
  EVP_DigestUpdate(state_.get(), data, size);  // cannot fail for an initialised state
}

std::array<unsigned char, 32> Sha256::digest() const {
  const Sha256 copy;
  std::array<unsigned char, 32> digest{};
  if (EVP_MD_CTX_copy_ex(copy.state_.get(), state_.get()) != 1 ||
      EVP_DigestFinal_ex(copy.state_.get(), digest.data(), nullptr) != 1)
    throw std::bad_alloc();
  return digest;
}

std::string Sha256::text() const {
  std::string text = "sha256:";
  for (const unsigned char byte : digest()) text += fmt::format("{:02x}", byte);
  return text;
}

std::uint64_t Sha256::key() const {
  std::uint64_t key = 0;
  std::memcpy(&key, digest().data(), sizeof key);
  return key;
}

}  // namespace typodont
