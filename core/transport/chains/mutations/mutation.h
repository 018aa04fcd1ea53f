// A kernel that proposes a path from a path. It can draw a proposal, and evaluate the density with which it would draw
// any path from any other. It does not know the target or the acceptance.
//
// Densities are products over the vertices that change, in the measures of path_vertex.h. Vertices that the two paths
// share are not included. The density is zero for paths that the kernel cannot propose.
#pragma once

#include <memory>

#include "transport/paths/path.h"

namespace ajar {

class Mutation {
 public:
  virtual ~Mutation() = default;
  virtual const char* name() const = 0;
  /// Whether it can propose a path from this one. The answer depends on the configuration of the path only.
  virtual bool suits(const Path& from) const = 0;
  /// Draws a complete path into `to` (PathSpace::complete has been called). Returns false when the proposal has no
  /// contribution. Adds to `rays`.
  virtual bool sample(const Path& from, Sampler& sampler, Path& to, uint64_t& rays) const = 0;
  virtual double pdf(const Path& from, const Path& to) const = 0;
};

/// Mutations and the shares with which they are chosen, common to all chains.
struct MutationShare {
  std::unique_ptr<Mutation> mutation;
  float share;
};

}  // namespace ajar
