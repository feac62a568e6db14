//! The application's tasks by name: the one list, from which every board makes them and by which its watchdog knows them.

/// Hands the list to another macro, behind `$for`: each task's name, its function in [`crate::app`], and the parts of the
/// board that it uses, by their names in [`Parts`](crate::board::Parts) and [`Board`](crate::board::Board).
#[macro_export]
macro_rules! application_tasks {
    ($($with:ident)::+ $(, $for:ty)?) => {
        $($with)::+! {
            $($for,)?
            Receive = receive::receive(reader: Reader, timer: Timer)
            Camera = camera::camera(front_end: FrontEnd, timer: Timer, counters: Counters)
            Transmit = transmit::transmit(writer: Writer, timer: Timer, counters: Counters)
            Beat = beat::beat(timer: Timer)
            Pulses = edges::pulses(timer: Timer)
            Edges = edges::edges(timer: Timer)
        }
    };
}

macro_rules! names {
    ($($name:ident = $module:ident::$task:ident $parts:tt)*) => {
        /// A task of the application.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Task {
            $(
                #[doc = concat!("`app::", stringify!($module), "::", stringify!($task), "`.")]
                $name,
            )*
        }

        /// How many there are.
        pub const TASKS: usize = [$(Task::$name),*].len();
    };
}
application_tasks!(names);
