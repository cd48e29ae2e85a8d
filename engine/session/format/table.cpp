#include "engine/session/format/table.h"

#include <utility>

namespace typodont::session {

bool Table::create(hid_t file, const std::string& path, const std::string& text, std::vector<Spec> specs,
                   std::size_t chunk, int deflate) {
  chunk_ = chunk;
  const H5 group = create_group(file, path);
  if (!group || !set_attribute(group.get(), "description", text)) return false;
  for (Spec& spec : specs) {
    const H5 properties = without_times(H5P_DATASET_CREATE);
    const hsize_t chunk_rows = chunk, zero = 0, unlimited = H5S_UNLIMITED;
    H5Pset_chunk(properties.get(), 1, &chunk_rows);
    H5Pset_shuffle(properties.get());
    H5Pset_deflate(properties.get(), static_cast<unsigned>(deflate));
    H5Pset_fletcher32(properties.get());  // adds a checksum that detects a damaged chunk
    H5 space(H5Screate_simple(1, &zero, &unlimited), H5Sclose);
    H5 dataset(H5Dcreate2(group.get(), spec.name.c_str(), spec.type.get(), space.get(), H5P_DEFAULT, properties.get(),
                          H5P_DEFAULT),
               H5Dclose);
    if (!dataset || !set_attribute(dataset.get(), "unit", spec.unit) ||
        !set_attribute(dataset.get(), "description", spec.text) ||
        (!spec.labels.empty() && !set_attribute(dataset.get(), "labels", spec.labels))) {
      return false;
    }
    columns_.push_back(
        {std::move(dataset), std::move(spec.type), spec.size, std::vector<std::byte>(spec.size * chunk)});
  }
  return true;
}

bool Table::write() {
  if (buffered_ == 0) return true;
  const hsize_t end = written_ + buffered_, offset = written_, count = buffered_;
  H5 memory(H5Screate_simple(1, &count, nullptr), H5Sclose);
  for (Data& column : columns_) {
    if (H5Dset_extent(column.dataset.get(), &end) < 0) return false;
    H5 space(H5Dget_space(column.dataset.get()), H5Sclose);
    if (H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, &offset, nullptr, &count, nullptr) < 0 ||
        H5Dwrite(column.dataset.get(), column.type.get(), memory.get(), space.get(), H5P_DEFAULT,
                 column.buffer.data()) < 0) {
      return false;
    }
  }
  written_ = end;
  buffered_ = 0;
  return true;
}

bool create_numbers(hid_t parent, const char* name, const char* unit, const char* text, hid_t type, hsize_t count,
                    const void* initial, H5& dataset, const std::string& labels) {
  const H5 properties = without_times(H5P_DATASET_CREATE);
  H5Pset_alloc_time(properties.get(), H5D_ALLOC_TIME_EARLY);
  H5 space(count == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &count, nullptr), H5Sclose);
  dataset = H5(H5Dcreate2(parent, name, type, space.get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT), H5Dclose);
  return dataset && set_attribute(dataset.get(), "unit", unit) && set_attribute(dataset.get(), "description", text) &&
         overwrite(dataset, type, initial) && (labels.empty() || set_attribute(dataset.get(), "labels", labels));
}

bool overwrite(const H5& dataset, hid_t type, const void* value) {
  return H5Dwrite(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, value) >= 0;
}

}  // namespace typodont::session
