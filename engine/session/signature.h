// Signatures of session files. A signature is the code HMAC-SHA256 of the file's bytes, stored in SESSION.h5.sig beside
// the file. Without the key, nobody can create a signed session, or change one unnoticed. Any thread except the servo's
// may call the functions. They throw Error.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "engine/session/opened_session.h"

namespace typodont::session {

/// A secret key of 32 bytes. The key file contains 64 hexadecimal digits and a line end, and only its owner may read
/// it.
struct SigningKey {
  std::array<unsigned char, 32> bytes{};
  /// 16 hexadecimal digits that identify the key without revealing it.
  std::string id() const;
};

SigningKey load_key(const std::filesystem::path& file);
/// Writes a new random key, made by the operating system, to a new file with mode 0600. Throws Error if the file
/// exists.
void make_key(const std::filesystem::path& file);

/// Computes the code HMAC (RFC 2104) with SHA-256.
std::array<unsigned char, 32> hmac_sha256(std::span<const unsigned char> key, std::span<const unsigned char> message);

/// The path of a session's signature, SESSION.h5.sig.
std::filesystem::path signature_file(const std::filesystem::path& session);
/// Signs the bytes of the session. Returns the path of the signature file, which is written completely or not at all.
std::filesystem::path sign_session(const OpenedSession& session, const SigningKey& key);
/// Checks a signature. Returns an empty text if the signature belongs to this key and the session's bytes, which are
/// the bytes that readers of `session` get. Otherwise returns what is wrong, as a part of a sentence: "no signature
/// (…)", "the signature is of another key, …", "the file changed after it was signed".
std::string what_is_wrong_with_signature(const OpenedSession& session, const SigningKey& key);
/// Checks a signature. Throws RunFailure if the signature is wrong, and Error if the key is invalid.
void require_signature(const OpenedSession& session, const std::filesystem::path& key);

}  // namespace typodont::session
