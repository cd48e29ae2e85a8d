// Kernel text, included once in each namespace of lanes (lane_ops.h): the change of samples by a cut, and the removed
// volume by tissue.

/// Raises samples: where `ahead` is set, a sample becomes its depth in the head (at most kInner), if the depth exceeds
/// both the old value and −kMargin. Returns the new values. `least`: the limit that the depth had to exceed; `rises`:
/// mask of the raised samples.
TYPODONT_KERNEL Floats raised_to(Floats old, Floats depth, Mask ahead, Floats& least, Mask& rises) {
  least = greater(old, all(-Sweep::kMargin));
  rises = more_where(ahead, depth, least);
  return pick(rises, depth, old);
}

/// Volume that each voxel loses when its distance rises from `was` to `is`, in integer units (haptics/share.h).
TYPODONT_KERNEL Ints share_taken(Floats was, Floats is) {
  const Floats before = greater(was, all(-0.5f)), after = greater(lesser(is, all(0.5f)), before);
  return as_ints(after + all(1.5f)) - as_ints(before + all(1.5f));
}

/// Sums the removed volume by label. Keeps a running sum as long as the label stays the same.
struct Taken {
  PerTissue* removed;
  Ints units = {};
  int groups = 0;
  std::uint8_t label = 0;

  /// Adds samples that all have the label `group_label`.
  TYPODONT_KERNEL void add(Ints taken, std::uint8_t group_label) {
    if (group_label != label) {
      close();
      label = group_label;
    }
    units += taken;
    if (++groups == 255) close();  // keeps the sum below 2^31: a voxel has 2^23 units
  }
  /// Adds samples with their labels.
  TYPODONT_KERNEL void add(Ints taken, const Tissue* labels) {
    std::uint64_t parts[kLanes / 8], differ = 0;
    std::memcpy(parts, labels, sizeof parts);
    for (std::uint64_t& part : parts) part &= kShown * 0x0101010101010101u;
    for (const std::uint64_t part : parts) differ |= part ^ (parts[0] & 0xff) * 0x0101010101010101u;
    if (!differ) {
      add(taken, static_cast<std::uint8_t>(parts[0]));
      return;
    }
    std::int32_t apart[kLanes];
    std::memcpy(apart, &taken, sizeof apart);
    for (int i = 0; i < kLanes; ++i) (*removed)[static_cast<std::size_t>(shown(labels[i]))] += kFractionUnit * apart[i];
  }
  TYPODONT_KERNEL void close() {
    std::int32_t apart[kLanes];  // a copy of the lanes, so that the sums themselves stay in a register
    std::memcpy(apart, &units, sizeof apart);
    std::int64_t sum = 0;
    for (const std::int32_t part : apart) sum += part;
    (*removed)[label] += kFractionUnit * static_cast<double>(sum);
    units = Ints{};
    groups = 0;
  }
};
