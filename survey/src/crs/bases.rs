//! Geographic systems whose datum shift is trusted.
//!
//! The list of definitions in use gives old national datums one shift for every place they are used at, and not always a
//! published one: it is 34 m off for Stereo 70, 120 m for the Balkan zones of MGI, 260 m for Pampa del Castillo. So
//! each system was compared with PROJ 9.5.1 and its copy of the EPSG dataset, on every code that stands on it, at three points
//! of the code's area of use. A system is listed where all of these lie within 1 m of a transformation that the dataset
//! publishes for the place, and within 5 m of the one PROJ prefers without grid files. By judgement were added 4258
//! (ETRS89), 4269 (NAD83) and 4617 (NAD83 CSRS), which stand for WGS 84 (their misses are 1.4 m at most, or in places where
//! nothing is published), and 4314 (DHDN), whose misses are two zones at sea.

/// EPSG codes of the trusted geographic systems, ascending.
#[rustfmt::skip]
pub(super) const TRUSTED: [u16; 259] = [
    3819, 3824, 3889, 4023, 4046, 4075, 4081, 4121, 4123, 4124, 4129, 4130, 4133, 4134, 4135, 4139,
    4140, 4143, 4146, 4148, 4149, 4150, 4151, 4152, 4153, 4155, 4158, 4159, 4163, 4164, 4165, 4166,
    4167, 4169, 4170, 4171, 4173, 4175, 4176, 4180, 4181, 4182, 4183, 4184, 4188, 4189, 4190, 4191,
    4192, 4193, 4195, 4196, 4200, 4201, 4202, 4203, 4204, 4205, 4207, 4212, 4213, 4216, 4219, 4221,
    4223, 4225, 4231, 4236, 4237, 4242, 4244, 4245, 4246, 4250, 4251, 4255, 4256, 4257, 4258, 4259,
    4262, 4266, 4269, 4273, 4274, 4275, 4277, 4282, 4283, 4285, 4289, 4293, 4298, 4299, 4300, 4302,
    4304, 4310, 4311, 4312, 4313, 4314, 4315, 4316, 4318, 4319, 4322, 4324, 4326, 4463, 4470, 4475,
    4483, 4558, 4601, 4602, 4604, 4605, 4607, 4611, 4612, 4614, 4615, 4616, 4617, 4619, 4621, 4622,
    4623, 4624, 4625, 4626, 4627, 4628, 4629, 4632, 4633, 4634, 4636, 4637, 4638, 4639, 4641, 4642,
    4643, 4644, 4646, 4657, 4658, 4659, 4661, 4662, 4664, 4665, 4666, 4667, 4668, 4669, 4670, 4672,
    4673, 4674, 4678, 4679, 4682, 4683, 4684, 4686, 4687, 4692, 4694, 4698, 4699, 4701, 4702, 4706,
    4707, 4708, 4709, 4710, 4711, 4712, 4714, 4715, 4716, 4717, 4719, 4720, 4721, 4722, 4723, 4724,
    4725, 4726, 4727, 4728, 4729, 4730, 4732, 4733, 4734, 4735, 4736, 4737, 4739, 4740, 4743, 4744,
    4747, 4748, 4749, 4750, 4752, 4754, 4755, 4756, 4758, 4759, 4761, 4762, 4763, 4764, 4765, 5013,
    5228, 5233, 5246, 5252, 5264, 5324, 5340, 5354, 5365, 5371, 5373, 5381, 5393, 5489, 5527, 5546,
    5593, 6135, 6207, 6311, 6365, 6706, 6881, 6882, 6883, 6892, 6894, 7373, 7881, 7886, 8351, 8427,
    8431, 8685, 8818,
];
