// Wrappers for the part of the HDF5 C API that sessions use: handles that close themselves, and errors with a reason.
#pragma once

#include <hdf5.h>

#include <string>
#include <string_view>
#include <utility>

#include "engine/session/format/columns.h"

namespace typodont::session {

/// Owns one HDF5 identifier.
class H5 {
 public:
  using Close = herr_t (*)(hid_t);
  H5() = default;
  H5(hid_t id, Close close) : id_(id), close_(close) {}
  H5(H5&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  H5& operator=(H5&& other) noexcept {
    if (this != &other) {
      reset();
      id_ = std::exchange(other.id_, -1);
      close_ = other.close_;
    }
    return *this;
  }
  ~H5() { reset(); }
  /// Closes the identifier. Returns false if closing failed, e.g. because buffered data could not be written.
  bool reset() noexcept {
    const hid_t id = std::exchange(id_, -1);
    return id < 0 || close_(id) >= 0;
  }
  hid_t get() const { return id_; }
  explicit operator bool() const { return id_ >= 0; }

 private:
  hid_t id_ = -1;
  Close close_ = nullptr;
};

/// While this object exists, HDF5 errors of this thread are stored for h5_reason() instead of printed.
class H5Quiet {
 public:
  H5Quiet();
  ~H5Quiet();
  H5Quiet(const H5Quiet&) = delete;
  H5Quiet& operator=(const H5Quiet&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

/// Text of the innermost reason of this thread's last HDF5 failure under an H5Quiet.
std::string h5_reason();

/// Opens a group or dataset by its path from `root`. Accepts only objects that the session writer could have created:
/// every name on the path is a hard link; a dataset has its data in this file, uses the writer's filters, has one
/// dimension, and claims no more data than the file can hold. Other links, external storage and virtual datasets are
/// refused, because they could expose the content of other files. Returns an empty handle if the object does not exist.
/// Throws Error(`file`, path, …).
H5 open_group(const std::string& file, hid_t root, const std::string& path);
H5 open_dataset(const std::string& file, hid_t root, const std::string& path);

hid_t h5_type(Type type);
/// A string type of fixed length, UTF-8, padded with null bytes.
H5 h5_string_type(std::size_t size);

// Attributes and texts. The setters return false on failure; the getters return false if the item does not exist or has
// another type.
bool set_attribute(hid_t object, const char* name, std::string_view text);
bool set_attribute(hid_t object, const char* name, double value);
bool set_attribute(hid_t object, const char* name, std::uint64_t value);
bool get_attribute(hid_t object, const char* name, std::string& text);
bool get_attribute(hid_t object, const char* name, double& value);
bool get_attribute(hid_t object, const char* name, std::uint64_t& value);
/// A scalar text dataset, UTF-8, of any length.
bool write_text(hid_t group, const char* name, std::string_view text);
/// Reads a text dataset. `dataset` is the result of open_dataset().
bool read_text(const H5& dataset, std::string& text);

}  // namespace typodont::session
