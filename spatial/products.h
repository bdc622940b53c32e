// Products of matrices with many entries, in the widest registers that the processor has.
#pragma once

#include <Eigen/Core>

namespace kinetostat::spatial {

/// A B and A' B. Every entry is the sum of its products one after the other, first to last, so that
/// it has the same digits on every processor.
Eigen::MatrixXd product(const Eigen::Ref<const Eigen::MatrixXd>& a,
                        const Eigen::Ref<const Eigen::MatrixXd>& b);
Eigen::MatrixXd transposed_product(const Eigen::Ref<const Eigen::MatrixXd>& a,
                                   const Eigen::Ref<const Eigen::MatrixXd>& b);
Eigen::MatrixXf transposed_product(const Eigen::Ref<const Eigen::MatrixXf>& a,
                                   const Eigen::Ref<const Eigen::MatrixXf>& b);

}  // namespace kinetostat::spatial
