// A way to propose a path from a path: a kernel. It can draw a proposal, and give the density with which it would
// have drawn any path from any other; it knows nothing of light carried or of acceptance.
//
// Densities are products over the vertices that change, in the measures of path_vertex.h; what the two paths
// share is not part of them. They are zero for what the kernel cannot propose.
#pragma once

#include <memory>

#include "transport/paths/path.h"

namespace ajar {

class Mutation {
 public:
  virtual ~Mutation() = default;
  virtual const char* name() const = 0;
  /// Could it propose anything from this path? Depends on the path's configuration only.
  virtual bool suits(const Path& from) const = 0;
  /// A complete path in `to` (PathSpace::complete has been called); false when the proposal carries nothing. `rays`
  /// counts.
  virtual bool sample(const Path& from, Sampler& sampler, Path& to, uint64_t& rays) const = 0;
  virtual double pdf(const Path& from, const Path& to) const = 0;
};

/// Mutations and how often each is chosen, shared by all chains.
struct MutationShare {
  std::unique_ptr<Mutation> mutation;
  float share;
};

}  // namespace ajar
