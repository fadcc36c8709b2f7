//! Why a stage cannot come to its end.

/// A stage has used up its steps.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StageError {
    /// A servo stage has not come to rest at its stress.
    #[error(
        "not at rest after {steps} steps: stress {stress:.6e} Pa of {goal:.6e} Pa, unbalanced force {unbalanced:.2e}; \
         allow more max_steps, a larger unbalanced, or a faster wall"
    )]
    NotSettled {
        /// Steps done in the stage.
        steps: u64,
        /// Stress on the wall (Pa).
        stress: f64,
        /// Stress asked for (Pa).
        goal: f64,
        /// Unbalanced force (1).
        unbalanced: f64,
    },
    /// The strain that ends a run was not reached.
    #[error(
        "strain {strain:.4e} of {goal:.4e} after {steps} steps; allow more max_steps or move the walls faster"
    )]
    StrainNotReached {
        /// Steps done in the stage.
        steps: u64,
        /// Strain reached (1).
        strain: f64,
        /// Strain asked for (1).
        goal: f64,
    },
    /// The state that ends a run was not reached.
    #[error(
        "{quantity} {value:.4e} of {goal:.4e} after {steps} steps; allow more max_steps, or another goal"
    )]
    GoalNotReached {
        /// What the stage waits for.
        quantity: &'static str,
        /// Steps done in the stage.
        steps: u64,
        /// Its value.
        value: f64,
        /// The value asked for.
        goal: f64,
    },
    /// The time factor that ends a consolidation was not reached.
    #[error(
        "T_v = {time_factor:.4} of {goal:.4} after {steps} steps; allow more max_steps or a larger time step"
    )]
    TimeFactorNotReached {
        /// Steps done in the stage.
        steps: u64,
        /// Time factor reached (1).
        time_factor: f64,
        /// Time factor asked for (1).
        goal: f64,
    },
}
