// Products of matrices with many entries, in the widest registers that the processor has.
#pragma once

#include <Eigen/Core>

namespace kinetostat::spatial {

/// C + A B, in the place of C, and A' B. To every entry its products are added one after the other,
/// first to last, so that it has the same digits on every processor.
void add_product(const Eigen::Ref<const Eigen::MatrixXd>& a,
                 const Eigen::Ref<const Eigen::MatrixXd>& b, Eigen::Ref<Eigen::MatrixXd> c);
Eigen::MatrixXd transposed_product(const Eigen::Ref<const Eigen::MatrixXd>& a,
                                   const Eigen::Ref<const Eigen::MatrixXd>& b);
Eigen::MatrixXf transposed_product(const Eigen::Ref<const Eigen::MatrixXf>& a,
                                   const Eigen::Ref<const Eigen::MatrixXf>& b);

}  // namespace kinetostat::spatial
